"""Jobs: long work that outlives the process that asked for it, on DBOS and an artefact store."""
