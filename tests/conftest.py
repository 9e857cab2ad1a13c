"""Made-up examples are the same in every run, so that a commit which passed passes again; `make test-deep` makes up new ones."""

from hypothesis import settings

settings.register_profile("fixed", derandomize=True, deadline=None)  # how long one takes is no matter of a unit test
settings.register_profile("new", derandomize=False, deadline=None)  # --hypothesis-profile=new
if settings.get_current_profile_name() == "default":  # nobody has chosen one: a trial of a mutant has its own
    settings.load_profile("fixed")
