"""What came out, for people: figures, pictures, tables, verdicts, and one page that holds all.

`findings` and `tables` turn numbers into verdicts and rows, `figures` and `pictures` into
images, `sections` puts them into the order of the page, `html` writes the page.
"""
