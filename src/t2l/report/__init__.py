"""A page that tells someone who was not there what was compared and what was found."""

from t2l.report.page import write_report

__all__ = ["write_report"]
