"""What a refusal has to be."""

from contextlib import contextmanager

import pytest


@contextmanager
def refused(kind, match):
    """Expect an exception whose text is one line with these words."""
    with pytest.raises(kind, match=match) as caught:
        yield caught
    assert "\n" not in str(caught.value)
