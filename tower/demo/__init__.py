"""Start the programs of a session and look after them."""
