"""The embedded automated stack: localize, perceive, plan, control, judge itself. It never decides who drives."""
