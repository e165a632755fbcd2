"""The one pool of the bench: tasks in processes that live on, on this machine or on a cluster."""
