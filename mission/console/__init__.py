"""The cockpit: a page in the browser of this computer, and the server behind it.

docs/design/console.md describes the protocol between the two.
"""
