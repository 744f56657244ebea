"""What people read: schedules, verdicts, the page, drawings, and the check of written files."""
