"""What ties the sciences together: sweeps, phantoms, scores, summaries."""
