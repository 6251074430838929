"""LIGGGHTS: every command it is given and every file it reads and writes.

Nothing outside this folder speaks its language.

`deck`
    Its decks as text, from the templates and the values of a packing or a run.
`start_files`
    What a run starts from, as text: the data file of the spheres, the STL of the walls.
`process`
    The program as a process, with commands in the words of the coupon.
`output`
    What it wrote, read: logs, cycle rows, dumps.
`failures`
    Reasons for a failed run, by name.
"""
