"""What a result depends on, and files that are whole: digests, requests, locks, ownership."""
