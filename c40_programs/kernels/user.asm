; Tasks of your own: docs/add-a-task.md.
