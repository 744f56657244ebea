"""The only room that knows the CAD kernel: reads CAD files, builds solids, writes STEP."""
