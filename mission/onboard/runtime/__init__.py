"""The one core of the sea and of the simulation: bytes in, bytes out, sans-IO.

runtime           the whole
operator_server   what operators say, and what they are answered; beside it commander, copies,
                  command_target, device_switches, pending_answers, staging, uploads
frontseat         one frame at a time, for boards that acknowledge; repeater for the others
resume_marker     what a restart would interrupt
records           what goes on record, and back
"""
