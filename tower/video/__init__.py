"""The cameras' pictures on the tower's side: receive, decode, keep the newest."""
