"""Claims about people who steer a robot: t2l has no such experiment."""

from t2l.study.claim import Claim

CLAIMS = [
    Claim("teleoperation_success", "People succeed as often at compliant, overdamped gains."),
    Claim("teleoperation_time", "People are as quick at compliant, overdamped gains."),
    Claim("teleoperation_rating", "People like compliant, overdamped gains as much."),
]
