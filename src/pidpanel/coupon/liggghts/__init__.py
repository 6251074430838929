"""LIGGGHTS: every command it is given and every file it writes; nothing else speaks to it.

`deck`
    What it reads: decks from the templates, data files.
`process`
    The program as a process that is fed command by command.
`output`
    What it wrote: logs, cycle rows, dumps; and its failures by name.
"""
