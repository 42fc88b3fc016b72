"""The pipeline from labels to image, once: its engine, the table of its stages, and what a stage computes."""
