"""Published breast models on one woman: what each is, and where its nipples, shape and force end up."""
