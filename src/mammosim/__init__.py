"""mammosim: from raw breast MR images to compression, X-ray images and dose."""
