"""Training of what is shipped as weights. Wants the extra `train`; nothing at run time imports it."""
