"""Analysis of recordings after the dive: replay, calibration, scores, the smoothed track."""
