// what stands before the heading
asyncr   asm sections /* of a file */


import   StandardLibrary
import CTLLibrary( ag,ax , ef )
import "../with blanks/Other.asm"
export   *
// about the signature
signature  :

  // two blank lines become one


  domain Tries subsetof   Integer
  dynamic abstract domain Order   // orders
  enum domain Colour={RED|GREEN | BLUE}
  enum domain Direction = {
    NORTH | // up
    EAST | SOUTH |
    WEST
  }
  enum domain Long = {AAAAAAAAAAAAAAAAAAAAAAAA | BBBBBBBBBBBBBBBBBBBBBBBBB | CCCCCCCCCCCCCCCCCC | DDDDDDDDDDD}
  //@Reference
  shared other:Agent->Order
  dynamic controlled f : Prod( Tries,Order ,Seq( Integer)) -> Powerset(Map(Integer,String))
  static g: Rule(Tries,Tries)
  // the last comment belongs to the signature
definitions:
domain Tries = {0..3}
domain Tries={0:3,2}
function g($a in Tries,$b in Order)=
   $a+1
function h = {
  1, 2,
  3, 4
}
function long($element in Tries) = union(someFunctionWithALongName($element), anotherFunctionWithALongName($element))
turbo rule r_t($x in Tries) in Integer = result := $x
invariant inv_a over f,g( Tries ),r_t: f>0 and g>0
INVAR f > 0
JUSTICE f = 1
COMPASSION( f=1, f=2 )
CTLSPEC ctlSpec_a:ag(f=1 implies ef(f=2))
CTLSPEC ag(someLongPropertyOfTheState and anotherLongPropertyOfTheState implies ax(aThirdLongProperty))

main rule r_Main = skip
   // after the main rule

default   init s0 :
function f=0
agent Order:r_t[1,2]
init s1:
  domain Order = {}
// the end
