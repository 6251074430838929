"""Dependencies of results, and complete files: digests, requests, locks, ownership."""
