"""Many areas: what is to be converted, cut out, spread over processes, and told about."""
