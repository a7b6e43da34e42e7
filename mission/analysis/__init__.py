"""What is done with recordings afterwards: replay, calibration, scores, the smoothed track."""
