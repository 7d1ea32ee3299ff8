"""Vehicles and cycles as files state them: found, read and checked."""
