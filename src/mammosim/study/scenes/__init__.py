"""Questions about one breast, and the effects that each calls for."""
