"""A dive as one page for people who were not there: pictures, figures and the story, in one file.

dive      what is shown of a recording    figures   depth, attitude, sensors, margins over time
map       plan, track and ellipses        page      all of it as HTML
numbers   of legs, where there is space
What does not live here: the story (story), the smoothed track (smoothing).
"""
