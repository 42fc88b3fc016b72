"""Fiducials, registration, segmentation and overlap of MR images."""
