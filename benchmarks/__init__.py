"""Every performance figure and every fault campaign, by one command each."""
