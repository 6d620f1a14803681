asm c048_specification
import StandardLibrary
signature:
  monitored near: Boolean
  monitored far: Boolean
  monitored same: Boolean
  out lamp: Boolean
definitions:
  main rule r_Main = lamp := near and far or same
