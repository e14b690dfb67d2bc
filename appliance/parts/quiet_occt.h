// While it lives, Open CASCADE prints nothing: its messengers lose their printers and get them back.
#pragma once

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_SequenceOfPrinters.hxx>

namespace deixis {

class QuietOcct {
  public:
    QuietOcct() : printers_(Message::DefaultMessenger()->Printers()) {
        Message::DefaultMessenger()->ChangePrinters().Clear();
    }
    ~QuietOcct() { Message::DefaultMessenger()->ChangePrinters() = printers_; }
    QuietOcct(const QuietOcct&) = delete;
    QuietOcct& operator=(const QuietOcct&) = delete;

  private:
    Message_SequenceOfPrinters printers_;
};

}  // namespace deixis
