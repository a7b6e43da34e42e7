"""The places in a mission's text, and edits of them that leave the rest of the text unchanged.

    text --language--> statements --handles--> places that a map can show and move
    text, an edit on the map --edits--> new text: comments and layout unchanged

The text is the reference. Each edit is verified by reading the new text: the edited place is where
it was wanted, and every other place is where it was (but for those that move with home). An edit
that cannot be made in this way is refused (EditError).
"""
