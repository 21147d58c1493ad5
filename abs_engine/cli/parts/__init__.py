"""Parts that commands share or are made of: options, settings files, progress, long steps."""
