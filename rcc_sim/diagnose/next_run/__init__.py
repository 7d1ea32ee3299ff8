"""Which run to drive next, within what the logs show the vehicle can do."""
