"""The stream for Foxglove and Lichtblick: their WebSocket protocol, the topics of black boxes.

live      a monitor's frames as messages      playing   a black box, at any speed
serving   the WebSocket server                layout    which panel shows which field

What does not live here: the topics and their schemas (onboard.stream).
"""
