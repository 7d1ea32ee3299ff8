"""How the tests are run, all of them."""

from hypothesis import settings

# a test is not wrong because the machine is busy
settings.register_profile("patient", deadline=None)
settings.load_profile("patient")

LONGEST = ("tests/test_docs.py", "tests/report/test_demo.py")
"""Files with tests of a minute and more."""


def pytest_collection_modifyitems(items):
    """Begin with what takes long: at the end no core waits for another's last test."""
    items.sort(
        key=lambda item: (
            not item.nodeid.startswith(LONGEST),
            item.get_closest_marker("slow") is None,
        )
    )
