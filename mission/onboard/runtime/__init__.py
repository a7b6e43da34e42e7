"""The core of the program at sea and in simulation: bytes in, bytes out, sans-IO.

runtime           the whole
operator_server   commands of operators, and their answers; beside it commander, copies,
                  command_target, device_switches, pending_answers, staging, uploads
frontseat         one frame at a time, for boards that acknowledge; repeater for the others
resume_marker     what a restart would interrupt
records           the records and their payloads, written and read
"""
