asm import_with_a_broken_export
import misspelt
import cut
import numbered(turns)
signature:
  controlled n: Integer
definitions:
  main rule r_Main = par
    n := range
    r_calibrate[]
    n := turns
  endpar
//--- misspelt.asm
module misspelt
exprt *  //~ L053
signature:
  static range: Integer
definitions:
  function range = 1
//--- cut.asm
module cut
export r_calibrate,
signature:  //~ L058
  static bearing: Integer
definitions:
  function bearing = 1
  rule r_calibrate = skip
//--- numbered.asm
module numbered
export 5  //~ L058
signature:
  static turns: Integer
definitions:
  function turns = 1
