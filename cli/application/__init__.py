"""The application: all that closecall does, for its commands, its pytest plugin and `closecall.api`, without click."""
