// one mistake, one message: where nothing closes the rule, too
asm equals_for_an_update_at_the_end
import StandardLibrary
signature:
  domain Side subsetof Integer
  controlled m: Integer
definitions:
  domain Side = {1 : 2}
  rule r_all = forall $x in Side with true do m = 1      //~ L050
  rule r_one = choose $x in Side with true do m = 1      //~ L050
  rule r_loop = while m < 1 do m = 1                     //~ L050
  rule r_set = m = 1                                     //~ L050
  rule r_term = m                                        //~ A028
  main rule r_Main = par r_all[] r_one[] r_loop[] r_set[] r_term[] endpar
