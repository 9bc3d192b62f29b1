"""The studio: a relief that is shaped in a browser, on the user's own machine.

A local web server (`server`) opens a document (`document`): a recipe with a table ``[relief]``. A thread (`worker`)
solves it whenever an option changes and sends the two parts of the heights (`frames`) to the page, which shades them
and computes every delta, height and width itself.
"""
