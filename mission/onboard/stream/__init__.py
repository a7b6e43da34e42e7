"""The stream of records behind every view of a mission: at sea, afterwards and in rehearsal.

topics      the table of topics: name, schema, meaning          schemas    helpers for JSON Schemas
senses      reports and fixes, decoded from recorded bytes      wellknown  schemas that others know
derived     values and positions that follow from records       plan       a mission's map
events      what happened, as a line of text each               sinks      receivers of records

What does not live here: the records themselves (runtime.records), files (blackbox).
"""
