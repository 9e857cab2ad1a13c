"""What crosses between processes: messages, the topic table, the link, pace, configuration. Imports none of our other rooms."""
