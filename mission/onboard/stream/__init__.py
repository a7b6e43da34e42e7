"""The one stream of records that whoever looks at a mission sees: at sea, afterwards, rehearsed.

topics      the table of topics: name, schema, what it says     schemas    words for JSON Schemas
senses      reports and fixes out of the recorded bytes         wellknown  schemas that others know
derived     what follows from the records: values, places       plan       a mission's map
events      what happened, in words, a line each                sinks      who takes records

What does not live here: the records themselves (runtime.records), files (blackbox).
"""
