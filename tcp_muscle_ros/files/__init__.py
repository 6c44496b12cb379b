"""Reading and writing of files that every room above needs: YAML as one exception, paths looked at before the work."""
