"""Every message that crosses between processes, one file per speaker. Decoded once, at the edge; see `wire.messages.base`."""
