"""Places of a mission's text, and edits of the text that change nothing beside them.

    text --language--> statements --handles--> what a chart can show and move
    text, an edit of the chart --edits--> the text again: comments and layout as they were

The text is the truth. An edit is verified by reading what it made: the place stands where it was
wanted, and every other where it was; what cannot be done so is refused (EditError).
"""
