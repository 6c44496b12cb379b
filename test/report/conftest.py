"""The diagnoses that reports are made of, once."""

import pytest
from report.diagnoses import ALL


@pytest.fixture(scope='session')
def made():
    """Every diagnosis of the helper: name -> (diagnosis, experiments)."""
    return {name: make() for name, make in ALL.items()}
