"""A study of coupons alone."""

import re
from collections.abc import Iterator, Mapping

from pidpanel.paths import SECTION
from pidpanel.study.base import SectionModel, Text
from pidpanel.study.coupon import Coupon
from pidpanel.study.mistakes import LONGEST_NAME, Mistake, is_formula

NAME = "[A-Za-z0-9][A-Za-z0-9_-]*"  # also of wildcards, in which Snakemake allows no braces
# Rule for names of folders: studies and dampers.
NAME_WORDS = (
    f"up to {LONGEST_NAME} letters a to z or A to Z, digits, '_' and '-', the first a letter or a "
    "digit"
)

RESERVED = ("coupon", "verification")  # folders of the results that belong to all studies


def is_name(name: str) -> bool:
    """Return whether a name suits a folder."""
    return len(name) <= LONGEST_NAME and re.fullmatch(NAME, name) is not None


class CouponStudy(SectionModel):
    """A study of the coupon alone: what the particles dissipate, and on what it depends."""

    name: Text
    """Name of the results folder; by default the name of the file."""
    title: Text = ""
    """Title of the report."""
    assumptions: tuple[Text, ...] = ()
    """Assumptions where the source gives no value; printed in the report."""
    coupon: Coupon | None = None
    """The honeycomb coupon that LIGGGHTS shakes."""

    def mistakes(self) -> Iterator[Mistake]:
        if is_formula(self.title):  # the source of the rows of an atlas
            yield Mistake(("title",), f"must not begin with {self.title.strip()[0]!r}")
        if not is_name(self.name):
            yield Mistake(("name",), f"must be {NAME_WORDS}")
        elif self.name in RESERVED:
            message = f"must be another name; results/{self.name} is shared by all studies"
            yield Mistake(("name",), message)
        if self.coupon is None and type(self) is CouponStudy:
            yield Mistake((), "must have a section coupon, panel, or both")

    @property
    def coupons(self) -> Mapping[str, Coupon]:
        """Coupons to simulate by name, that of the section first."""
        return {SECTION: self.coupon} if self.coupon else {}

    @property
    def is_coupled(self) -> bool:
        """Whether panel and particles are integrated together; see `Study`."""
        return False
