"""Programs that prove that the suite keeps working; their figures go into docs/reliability.*."""
