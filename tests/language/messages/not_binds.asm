asm not_binds
import StandardLibrary
signature:
  controlled a: Boolean
  controlled b: Boolean
definitions:
  main rule r_Main = if not a = b then a := b endif  //~ W001
