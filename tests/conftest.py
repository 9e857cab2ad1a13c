"""Made-up examples are the same in every run, so that a commit which passed passes again; `make test-deep` makes up new ones.

How long one takes to make up or to try is no matter of a unit test: hypothesis counts real time, on a busy machine too.
"""

from hypothesis import HealthCheck, settings

for name, always_the_same in (("fixed", True), ("new", False)):  # --hypothesis-profile=new
    settings.register_profile(name, derandomize=always_the_same, deadline=None, suppress_health_check=[HealthCheck.too_slow])
if settings.get_current_profile_name() == "default":  # nobody has chosen one: a trial of a mutant has its own
    settings.load_profile("fixed")
