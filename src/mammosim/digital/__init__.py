"""Digital volunteers: virtual patients whose truth is known, scanned in several positions."""
