"""Digital volunteers: made women whose truth is known."""
