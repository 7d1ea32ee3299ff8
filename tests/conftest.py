"""How the tests are run, all of them."""

from hypothesis import settings

# a test is not wrong because the machine is busy
settings.register_profile("patient", deadline=None)
settings.load_profile("patient")
