"""From X-ray spectra to images and dose."""
