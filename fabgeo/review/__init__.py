"""What people read: schedules, the check of the written files, the page, drawings."""
